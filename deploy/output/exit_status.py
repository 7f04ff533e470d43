"""What the `disknav` command says by its exit status."""

EXIT_ARRIVED, EXIT_OTHERWISE, EXIT_INVALID, EXIT_FAULT, EXIT_INTERRUPTED = 0, 1, 2, 3, 130
