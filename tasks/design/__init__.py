"""Design a survey before going out: what lean sigma a set of stations will give."""

from tasks.design.improvement import BestPlace, best_place
from tasks.design.prediction import Prediction
from tasks.design.shaft import Bands, Shaft, slices, whole_surface
from tasks.design.sight import Errors, Hidden, Levels, Scanning, Site
from tasks.design.survey import Outlook, StationOutlook, Survey, foresee, predict_survey, sites_at

__all__ = [
    "Bands",
    "BestPlace",
    "Errors",
    "Hidden",
    "Levels",
    "Outlook",
    "Prediction",
    "Scanning",
    "Shaft",
    "Site",
    "StationOutlook",
    "Survey",
    "best_place",
    "foresee",
    "predict_survey",
    "sites_at",
    "slices",
    "whole_surface",
]
