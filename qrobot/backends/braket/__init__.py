"""Amazon Braket: the local simulator and managed devices."""
