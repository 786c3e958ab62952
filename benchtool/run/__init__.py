"""Running a plan on a session: every case conducted, recorded and assessed in turn."""
