"""What a page of the cockpit is shown: computed in a process of its own, without a page."""
