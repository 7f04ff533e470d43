"""How the runs of a study are executed: on all cores or on a cluster, each result kept at once."""
