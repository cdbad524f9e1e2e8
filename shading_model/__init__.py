"""The approximate shading model: arrays in, arrays out.

What it is made of, in the order in which a model is built:

========================  ==========================================================================
`arrays`, `errors`        array types, the checks of user input, and how a fault is told
`pixel_grid`              the graph of a mask's pixels, and Poisson equations on it
`normal_field`            the smoothest normals with given values on the outline (`eq:normal`)
`contour_shape`           the coarse shape of a mask: those normals, integrated to heights
`height_field`            normals of heights
`retinex`                 a photograph split into albedo and shading
`illumination`            spherical harmonics in two conventions, and point lights
`illumination_fit`        the light that explains a shading on a shape (`eq:argminL`)
`harmonic_conversion`     one convention of spherical harmonics to the other, and rotations
`geometric_detail`        S_g, what a dictionary of smooth patches leaves of a shading
`object_model`            all of it together: build a model, relight it (`eq:model`)
`probe_sphere`            the circle of a photographed sphere, and the normals on it
`diffuse_probe`           a matt sphere's light, with `light_probe` (cut out) and `distant_light`
`chrome_probe`            the direction of a light from its highlight on a mirror sphere
`relative_light`          the light of a picture over another of the view, told from the object
`depth_map`               millimetres on a sensor's grid, and where that grid lies in a picture
`depth_cleaning`          its readings without the bad ones, filled and smoothed
`sensor_shape`            the base shape that a depth sensor gives
`photometric_stereo`      normals and albedo from pictures under known lights
`normal_integration`      heights from normals, over any mask
`seeds`                   random generators seeded from names
========================  ==========================================================================

Examples
--------
A gray ball, built from one picture and its mask, and lit from the right:

>>> import numpy as np
>>> from shading_model.geometric_detail import PatchDictionary
>>> from shading_model.illumination import LinearHarmonics
>>> from shading_model.object_model import ModelParameters, Weights, build_model
>>> rows, columns = np.mgrid[-20:21, -20:21]
>>> mask = np.hypot(rows, columns) < 19
>>> photograph = np.full((41, 41, 3), 0.3)
>>> dictionary = PatchDictionary(np.eye(16).reshape(16, 4, 4))  # datasets ships a learned one
>>> model = build_model(photograph, mask, ModelParameters(dictionary))
>>> light = LinearHarmonics(np.array([0.5, 0, 0, 0.5, 0, 0, 0, 0, 0]))
>>> relit = model.relight(light, Weights(parametric=0.5, geometric=1.0))
>>> bool(relit[20, 30, 0] > relit[20, 10, 0]), bool(np.isnan(relit[0, 0]).all())
(True, True)
"""
