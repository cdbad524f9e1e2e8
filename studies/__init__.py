"""Two-alternative forced-choice (2AFC) studies: design, server, response store and analysis.

Design
    `study_file` reads a study into `study_records`, section by section (`toml_table`,
    `study_pairs`, `study_sections`, `study_plan`) with its pictures (`stimulus_files`).
    `schedules` and `side_sequences` decide who sees what, `balance` counts it, `power` (with
    `power_simulation`) says how many subjects are needed. `example_study` (with
    `example_pictures`) is a whole study, `bare_study` one without pictures.
Serving
    `serving` and `server_process` start the `server`: `session_assignment`, `session_documents`,
    `served_stimuli`, `request_schemas`, `request_limits`, `completion_codes`, `secret_key`.
    `page_build` builds what stands in ``page/``. `simulated_load` measures it all.
Store
    `response_store`: `store_engine`, `store_schema`, `store_statements`, `store_rows`.
Data
    `tables` and `table_columns` are the four tidy tables; `exporting` and `importing` move them
    (`csv_files`, `foreign_rows`, `mturk_batches`, `prolific_exports`, `published_sets`), mapped
    files are read by `mapped_files` and its like; `simulation` answers a study by `observers`.
Analysis
    the package `analysis`.
"""
