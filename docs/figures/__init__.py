"""The figures of the site: each module has a function ``draw`` that returns one."""
