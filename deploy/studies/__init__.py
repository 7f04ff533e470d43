"""Studies: tables measured over many runs, each reproducible by one command."""

from typing import Literal

StudyName = Literal["tightness", "tuning", "robustness", "arrival", "delay", "peers", "scale"]
