"""Classical methods: exact programmes, batching of whole orders, PyVRP."""
