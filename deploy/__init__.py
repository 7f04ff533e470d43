"""The `disknav` command: launch, supervise, record, look into and study fleets."""
