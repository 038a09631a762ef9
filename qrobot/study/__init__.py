"""Studies of plans and backends: benchmarks, and the paper reproduced."""

__all__: list[str] = []
