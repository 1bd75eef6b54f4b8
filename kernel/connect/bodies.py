"""Nodes that move as one rigid body: a union-find with members in order."""

from __future__ import annotations


class Bodies:
    """Nodes that were never joined are bodies of their own."""

    def __init__(self) -> None:
        self._parent: dict[int, int] = {}

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
        self._parent.setdefault(a, a)
        self._parent[b] = a

    def groups(self) -> dict[int, list[int]]:
        """All bodies of two or more nodes, members in order."""
        result: dict[int, list[int]] = {}
        for node in sorted(self._parent):
            result.setdefault(self.find(node), []).append(node)
        return {root: members for root, members in result.items() if len(members) > 1}

    def members(self, node: int) -> list[int]:
        """All nodes of the node's body, in order."""
        return self.groups().get(self.find(node), [node])
