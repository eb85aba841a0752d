"""From a job to takes, whatever the method: the job, the driver, attempts, actions in a row, refinement."""
