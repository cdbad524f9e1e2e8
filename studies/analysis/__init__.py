"""What the answers to a study say, and how surely.

Rates
    `intervals` has Wilson's, the cluster-robust and the two-way interval and the paper's own mean;
    `cluster_bootstrap` draws subjects; `rates` makes the rows of the tables.
Comparisons
    `arms` says what may be compared; `cell_means` compares methods, `group_tests` groups and
    `equivalence` a rate with chance; `planned_tests` makes all tests of a study and corrects them.
Models
    `mixed_model` (by `laplace`), `estimating_equations` and `bradley_terry`, whose answers
    `model_inputs` checks; `study_models` fits those of a study, `model_rows` writes them down.
Study
    `exclusion_flow` and `subpopulations` say whose answers count where; `study_analysis` does all
    of it.
"""
