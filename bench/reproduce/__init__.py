"""Hold a published table of results to itself and to a new run: read it, criticise it, repeat it, judge every cell."""
