"""SIRFS: shape, illumination and reflectance of an object from the shading of one photograph.

The rival of the paper's tables ("B & M"): Barron and Malik, *Shape, Illumination, and Reflectance
from Shading*, TPAMI 37(8), 2015, in the form of its release 1.5, written anew from its formulas.

A fit minimises ``loss_A(A) + loss_Z(Z) + loss_L(L)`` over a height map Z and log-harmonic light L;
log albedo is what they leave of the log photograph, ``A = log I - S(Z, L)``.

==========================  ========================================================================
`settings`                  weights of the terms for each kind of light and number of channels
`priors`                    what was learned from the training objects, and the shipped file of it
==========================  ========================================================================
"""
