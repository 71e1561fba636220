"""A topic of reports: what differs besides the algorithms, and the leader under the same conditions."""
