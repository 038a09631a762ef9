"""What `make bench` measures: `python -m benchmarks.run`, from the root of the checkout."""
