"""What the `disknav` command says by its exit status; a signal that ends it says 128 and its number."""

EXIT_ARRIVED, EXIT_OTHERWISE, EXIT_INVALID, EXIT_FAULT = 0, 1, 2, 3
