"""The commands of relightlab, one module for each group."""
