"""The report of an epoch for those who own, survey and sign: a PDF and a single-file web page of the same contents."""
