"""The campaign file: its tables, their units and bounds, and how it is read."""

from tasks.settings.campaign import Campaign
from tasks.settings.epochs import Epoch, Reference, Station
from tasks.settings.reading import load_campaign
from tasks.settings.schemes import BUILT_IN, Scheme

__all__ = ["BUILT_IN", "Campaign", "Epoch", "Reference", "Scheme", "Station", "load_campaign"]
