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
`fit`                       one photograph, or several of one shape, from start to result
`framing`, `problem`        the rectangle that is fitted, and the problem posed there
`objective`, `view`         the loss and its gradient: of the shape, and of one photograph's albedo
`entropy`, `depth_term`     terms of the histogram of albedo, and of an external depth map
`regions`                   runs of pixels, pairs of neighbours, the outline
``*_kernels``               the compiled inner loops, each with its adjoint
`descent`, `quasi_newton`,  the minimiser: the pyramid's metric, limited memory, strong Wolfe
`line_search`, `pyramid`    conditions
`result`, `fit_files`       what a fit yields, and files of it
`metrics`                   its errors against the truth
==========================  ========================================================================
"""
