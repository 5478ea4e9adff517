"""The server of the cockpit: on this machine alone, behind a guard, a session for each tab of a browser."""
