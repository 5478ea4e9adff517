"""Published numbers of the ready drives beside ours."""
