"""The page: header, levers, answers, drawing, sweep, modes and evidence, laid out for one screen."""
