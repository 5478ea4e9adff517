"""Undo and redo over states; a drag is one step."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from .state import PageState

__all__ = ["StateHistory", "Step"]

# Steps kept: more than anybody takes back, some kB each since the model text is shared.
_MOST = 300


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A state, None of a page without a model; what led to it, and the key under which changes that follow are one."""

    state: PageState | None = None
    label: str = ""
    key: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StateHistory:
    """Steps behind, the present one, and those taken back, the next one first."""

    now: Step = field(default_factory=Step)
    behind: tuple[Step, ...] = ()
    ahead: tuple[Step, ...] = ()

    @property
    def present(self) -> PageState | None:
        return self.now.state

    @property
    def undo_label(self) -> str:
        """What undo takes back; empty where there is nothing."""
        return self.now.label if self.behind else ""

    @property
    def redo_label(self) -> str:
        """What redo does again; empty where there is nothing."""
        return self.ahead[0].label if self.ahead else ""

    def push(self, state: PageState, label: str, key: str | None = None) -> StateHistory:
        """The history with a new state; one of the same key as the last replaces it, an equal one changes nothing."""
        if state == self.present:
            return self
        step = Step(state=state, label=label, key=key)
        if key is not None and key == self.now.key and self.behind:
            return replace(self, now=step, ahead=())
        return StateHistory(now=step, behind=(*self.behind, self.now)[-_MOST:])

    def closed(self) -> StateHistory:
        """The history whose next change is a step of its own, whatever its key: a drag has ended."""
        return self if self.now.key is None else replace(self, now=replace(self.now, key=None))

    def undo(self) -> StateHistory:
        if not self.behind:
            return self
        return StateHistory(now=self.behind[-1], behind=self.behind[:-1], ahead=(self.now, *self.ahead)).closed()

    def redo(self) -> StateHistory:
        if not self.ahead:
            return self
        return StateHistory(now=self.ahead[0], behind=(*self.behind, self.now), ahead=self.ahead[1:]).closed()

    def with_file(self, before: PageState, saved: PageState) -> StateHistory:
        """The history after a state was written to a file: that is the file of all steps of the same model."""
        name = (before.path, before.drive, before.name)

        def step(one: Step) -> Step:
            if one.state is None or one.state == saved or (one.state.path, one.state.drive, one.state.name) != name:
                return one
            if one.state == before:
                return replace(one, state=saved)
            return replace(
                one, state=replace(one.state, path=saved.path, name=saved.name, drive=None, trusted=saved.trusted)
            )

        return StateHistory(
            now=step(self.now), behind=tuple(map(step, self.behind)), ahead=tuple(map(step, self.ahead))
        )
