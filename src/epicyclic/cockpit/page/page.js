// Keys within a list of buttons, marked data-keys: one stop of the tab key, arrows go on, Home and End to its ends.
(() => {
  const FORWARD = ["ArrowDown", "ArrowRight"];
  const BACK = ["ArrowUp", "ArrowLeft"];
  const within = (list) => [...list.querySelectorAll("button")].filter((button) => !button.hidden && !button.disabled);

  document.addEventListener("keydown", (event) => {
    const list = event.target.closest?.("[data-keys]");
    if (!list || event.ctrlKey || event.metaKey || event.altKey || event.target.tagName !== "BUTTON") return;
    const buttons = within(list);
    const now = buttons.indexOf(event.target);
    let next = -1;
    if (FORWARD.includes(event.key)) next = Math.min(now + 1, buttons.length - 1);
    else if (BACK.includes(event.key)) next = Math.max(now - 1, 0);
    else if (event.key === "Home") next = 0;
    else if (event.key === "End") next = buttons.length - 1;
    else return;
    event.preventDefault();
    buttons[next].focus();
    if (list.dataset.keys === "choose") buttons[next].click();
  });
  // the tab key leaves the list: only the button that has or had the focus, else the first, is a stop
  document.addEventListener("focusin", (event) => {
    const list = event.target.closest?.("[data-keys]");
    if (!list) return;
    for (const button of within(list)) button.tabIndex = button === event.target ? 0 : -1;
  });
})();

// Escape ends what is enlarged or unfolded; what swings ends in the panes, an open menu closes by itself.
document.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || event.defaultPrevented) return;
  document.querySelector(".cockpit-large [aria-label$='back into the column']")?.click();
  for (const details of document.querySelectorAll("details[open]")) details.open = false;
});

// A button that goes while it has the focus hands it to what stands in its place: the next control of its row.
(() => {
  const isSeen = (element) => element.isConnected && element.checkVisibility();
  const CONTROLS = "button, input, select, [tabindex='0']";
  document.addEventListener("click", (event) => {
    const button = event.target.closest?.("button");
    const row = button?.parentElement;
    if (!row) return;
    // the server takes it away a moment later
    for (const wait of [100, 400, 1500, 5000, 15000]) {
      setTimeout(() => {
        if (document.activeElement !== document.body || isSeen(button)) return;
        [...row.querySelectorAll(CONTROLS)].find((one) => isSeen(one) && !one.disabled)?.focus();
      }, wait);
    }
  }, true);
})();
