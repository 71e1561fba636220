"""A topic of reports: the methods of the run, as a paper describes them."""
