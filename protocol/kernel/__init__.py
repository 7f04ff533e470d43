"""The safety kernel: which disks are bound to each other, what each robot obeys, and where each may be.

`ledger` is the coordinator's half, `robot` the half of each robot, `pair` the protocol of one line between
two lives, `records` their common data types. No rule looks into a place, a region or a line: geometry
answers a few questions about them.
"""
