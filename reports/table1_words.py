"""The fixed prose of the Table 1 report."""

from __future__ import annotations

from reports.content import Stamp

SYNTHETIC_STAMP = Stamp(
    "SYNTHETIC SET",
    "These objects are generated, not photographed. The numbers test the method and the code; they"
    " do not reproduce the paper's table, which needs the MIT-Berkeley set.",
)
COMPARABLE = (
    "Not the absolute values. The paper does not say which lights it drew or how bright they were,"
    " and IMSE grows with the square of the target's brightness; a ratio to the published value"
    " mostly measures that difference. What can be compared is the {order} of the entries, their"
    " {proportions}, and the {relative error}, IMSE\u2032 over the mean squared target, which has"
    " no unit."
)
RIVAL_NOTE = (
    "The SIRFS behind rows (b) and B+M is written anew after the description of its release 1.5,"
    " and fits photographs in colour; the paper cites the version of 2012."
)
QUICK_STAMP = Stamp(
    "QUICK",
    "Without SIRFS, as the option --quick asks: the rows (b) and B+M of the published table were"
    " left out, and nothing is filled in for them. All other rows are as in the whole table.",
)
DETAIL_EFFECT = (
    "Whether the detail layers lower the error at all. Each rule against the same model without"
    " them:"
)
NO_DIFFERENCE = "All entries that were measured here come in the published order."
METHOD = (
    "The method: Z. Liao, K. Karsch, H. Zhang and D. Forsyth, “An Approximate Shading Model with"
    " Detail Decomposition for Object Relighting”, {International Journal of Computer Vision}"
    " 127(1), 22–37, 2019, doi 10.1007/s11263-018-1090-6."  # noqa: RUF001  a range of pages
)
PHOTOGRAPHS = (
    "The photographs: R. Grosse, M. Johnson, E. Adelson and W. Freeman, “Ground truth dataset and"
    " baseline evaluations for intrinsic image algorithms”, ICCV 2009; depth and lights: J. Barron"
    " and J. Malik, “Shape, Illumination, and Reflectance from Shading”, TPAMI 37(8), 2015."
    " Pictures of that set in this report are for educational, research and not-for-profit use,"
    " under the copyright of the Regents of the University of California."
)
