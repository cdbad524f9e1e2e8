"""Where pictures come from: every source yields the records of `datasets.records`.

Sets
    `mit_berkeley` (with `mit_axes`), and `synthetic`, which needs no data: `synthetic_shapes` lists
    its twenty objects, `synthetic_objects` makes one of them; `psm_uw` and `rgbd_mitten` (with
    `picture_series`), real objects under many lights. `time_of_flight` (with `interreflection`)
    simulates a depth sensor before an object whose shape is known.
Finding and fetching them
    `catalogue` (what is known), `locations` (the data root), `fetching` (with `resuming_download`),
    `verification`, `file_tree`.
Lights
    `illumination_pools` (the draws of Table 1), `environment_maps` (the pool that ships),
    `training_lights` (what priors are learned from).
Files
    `image_files`, `openexr_files`, `photograph_files` (a picture and its mask, ready for a model),
    `probe_files` (pictures of light probes),
    `model_files` (saved models), `atomic` (whole or absent).
What ships for building models
    `model_parameters`, `shading_dictionary`.
"""
