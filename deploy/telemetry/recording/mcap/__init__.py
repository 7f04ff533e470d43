"""MCAP files: written chunk by chunk, read up to where they end or are damaged."""
