"""Uploads over HTTP that go on where they stopped (the tus protocol, by tuspyserver), into the inbox of a watch."""
