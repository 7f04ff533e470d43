"""The safety kernel: bindings between disks, the lines that robots obey, and the regions that they may be in.

`ledger` is the coordinator's part, `robot` the part of each robot, `pair` the protocol of one line between
two lives, `records` their common data types. The rules treat places, regions and lines as opaque: geometry
answers a few questions about them. docs/safety.md explains them.
"""
