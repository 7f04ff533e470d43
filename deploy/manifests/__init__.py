"""Files by which an existing orchestrator runs a secured fleet: Docker Compose, Kubernetes, systemd."""
