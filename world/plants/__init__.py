"""Plants: how commands move disks."""
