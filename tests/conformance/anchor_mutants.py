"""Backends with anchors that move wrongly, each with the check that must catch it."""

from __future__ import annotations

from cdpr_traps.backend import Wrapped


class Unfollowed(Wrapped):
    """Anchors that move are ignored."""

    def follow(self, anchors):
        pass


class FollowedOnce(Wrapped):
    """Time does not return to zero at a reset."""

    def follow(self, anchors):
        self.inner.follow(anchors)
        self.inner.restart = lambda: None


class FollowedLate(Wrapped):
    """The anchors are those of the middle of the step, frozen."""

    follows = False

    def follow(self, anchors):
        self.placing = anchors.placing(self.inner.frame.line_table)
        self.follows = True

    def loads(self):
        if self.follows:
            self.placing((self.count - 0.5) * self.physics_step)
        return super().loads()


MOVING = {"features": ("moving_anchors",)}
MUTANTS = {kind: (MOVING, ["uniform_motion_changes_nothing"]) for kind in (Unfollowed, FollowedOnce, FollowedLate)}
