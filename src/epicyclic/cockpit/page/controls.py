"""Plain controls of the page: native elements, which browsers make reachable by keyboard, and texts sent on change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.elements.mixins.text_element import TextElement


class Words(TextElement):
    """An element with a text; an equal one is not sent again."""

    def __init__(self, tag: str = "span", text: str = "", *, classes: str = "") -> None:
        super().__init__(tag=tag, text=text)
        self.classes(classes)

    def say(self, text: str) -> None:
        if self.text != text:
            self.set_text(text)


def box(classes: str, tag: str = "div") -> Element:
    """A container."""
    return Element(tag).classes(classes)


def button(text: str, on_click: Callable[..., Any], *, classes: str = "ck-small", label: str = "") -> Words:
    """A native button; label : its name where the text is none."""
    made = Words("button", text, classes=classes)
    made.props["type"] = "button"
    if label:
        made.props["aria-label"] = label
        made.props["title"] = label
    made.on("click", lambda _: on_click())
    return made


def prop(element: Element, name: str, value: object) -> None:
    """Set a property and send it, where it is another one."""
    if element.props.get(name) != value:
        element.props[name] = value
        element.update()


def hide(element: Element, hidden: bool) -> None:
    """Take an element away from the page and its readers, or show it."""
    if bool(element.props.get("hidden")) != hidden:
        if hidden:
            element.props["hidden"] = True
        else:
            del element.props["hidden"]
        element.update()
