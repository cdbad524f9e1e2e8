"""SIRFS: shape, illumination and reflectance of an object from the shading of one photograph.

The rival of the paper's tables ("B & M"): Barron and Malik, *Shape, Illumination, and Reflectance
from Shading*, TPAMI 37(8), 2015, in the form of its release 1.5, written anew from its formulas.

A fit minimises ``loss_A(A) + loss_Z(Z) + loss_L(L)`` over a height map Z and log-harmonic light L;
log albedo is what they leave of the log photograph, ``A = log I - S(Z, L)``.

==========================  ========================================================================
`settings`                  weights of the terms for each kind of light and number of channels
`priors`                    what was learned, made of `scale_mixture`, `absolute_albedo`,
                            `absolute_color` (with `bending`) and `light_prior`
`prior_files`               files of it, and the shipped one
`prior_training`            learning it again, from `training_data` and `light_training`;
                            `smoothness_search` chose the one weight that is not published
`result`, `fit_files`       what a fit yields, and files of it
`metrics`                   its errors against the truth
==========================  ========================================================================
"""
