"""Where pictures come from: every source yields the records of `datasets.records`."""
