"""Jobs of many independent blocks: in this process, by local workers, or on a Dask cluster."""
