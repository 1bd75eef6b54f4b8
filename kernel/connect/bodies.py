"""A union-find with members in order: nodes of one rigid body, walls of one row of the ledger."""

from __future__ import annotations


class Bodies:
    """Nodes that were never joined are bodies of their own."""

    def __init__(self) -> None:
        self._parent: dict[int, int] = {}
        self._members: dict[int, list[int]] = {}

    def find(self, node: int) -> int:
        """The body of the node, by its smallest member."""
        root = node
        while self._parent.get(root, root) != root:
            root = self._parent[root]
        while self._parent.get(node, node) != root:
            self._parent[node], node = root, self._parent.get(node, node)
        return root

    def join(self, one: int, other: int) -> None:
        """The bodies of two nodes become one."""
        a, b = sorted((self.find(one), self.find(other)))
        if a == b:
            return
        self._parent.setdefault(a, a)
        self._parent[b] = a
        self._members.setdefault(a, [a]).extend(self._members.pop(b, [b]))

    def groups(self) -> dict[int, list[int]]:
        """All bodies of two or more nodes, by their smallest member; members in order."""
        return {root: sorted(self._members[root]) for root in sorted(self._members)}

    def members(self, node: int) -> list[int]:
        """All nodes of the node's body, in order."""
        return sorted(self._members.get(self.find(node), [node]))
