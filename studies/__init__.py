"""Two-alternative forced-choice (2AFC) studies: design, server, response store and analysis.

No module stands here yet; the package holds the name.
"""
