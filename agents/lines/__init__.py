"""Separating lines: they keep any two disks apart under any fault of the network.

For each pair of robots i < j there is a line with unit normal n, pointing from i to j, and an
offset c. A robot that obeys it keeps its whole disk on its own side: n.x_i + rho_i <= c, or
n.x_j - rho_j >= c. Two robots that obey the same line cannot touch. `negotiation` moves the line so that
at every instant both obey a common one; `separating_lines` keeps all pairs of one robot.
"""
