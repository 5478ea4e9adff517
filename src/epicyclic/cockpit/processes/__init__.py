"""What computes: the live process, jobs, and the session of one page that asks them."""
