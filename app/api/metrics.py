"""What the service measures of itself, for Prometheus: GET /metrics."""

from __future__ import annotations

import time
from collections.abc import Iterator

from fastapi import FastAPI
from prometheus_client import CollectorRegistry, Counter, GCCollector, Histogram, PlatformCollector, ProcessCollector
from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.api.context import Context, Ctx
from app.tables import STATES

REQUEST_BUCKETS = (0.005, 0.02, 0.1, 0.5, 2.0, 10.0, 60.0)
"""Upper bounds of a request's time, s."""

NO_ROUTE = "none"
"""The route of requests that no operation answers: their paths are the sender's, and endless."""


class Metrics:
    """Counts of requests, and at each look the state of the jobs."""

    def __init__(self, context: Context) -> None:
        self.registry = CollectorRegistry()
        for collector in (ProcessCollector, PlatformCollector, GCCollector):
            collector(registry=self.registry)
        self.requests = Counter(
            "csgmesh_requests", "Requests answered.", ("method", "route", "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "csgmesh_request_seconds",
            "Time from a request to the first byte of its answer.",
            ("method", "route"),
            buckets=REQUEST_BUCKETS,
            registry=self.registry,
        )
        self.registry.register(_Jobs(context))


class _Jobs:
    """The job table and the workers, counted whenever somebody looks."""

    def __init__(self, context: Context) -> None:
        self._context = context

    def describe(self) -> list[Metric]:
        """Nothing is known before somebody looks: registering must not ask the database."""
        return []

    def collect(self) -> Iterator[Metric]:
        """Jobs by state; workers by what they do; models, meshes."""
        counts = self._context.store.counts()
        jobs = GaugeMetricFamily("csgmesh_jobs", "Jobs on record, by state.", labels=["state"])
        for state in STATES:
            jobs.add_metric([state], counts.jobs.get(state, 0))
        yield jobs
        yield GaugeMetricFamily("csgmesh_models", "Models on record.", value=counts.models)
        yield GaugeMetricFamily("csgmesh_meshes", "Meshes on record.", value=counts.meshes)
        workers = GaugeMetricFamily("csgmesh_workers", "Worker processes for jobs, by state.", labels=["state"])
        busy, total = self._context.jobs.occupied()
        workers.add_metric(["busy"], busy)
        workers.add_metric(["idle"], total - busy)
        yield workers


class Measured:
    """Counts the requests of an application, by method, route and status."""

    def __init__(self, application: ASGIApp, metrics: Metrics) -> None:
        self._application = application
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on; count it once its answer begins."""
        if scope["type"] != "http":
            await self._application(scope, receive, send)
            return
        start = time.perf_counter()

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                route = getattr(scope.get("route"), "path", NO_ROUTE)
                self._metrics.requests.labels(scope["method"], route, message["status"]).inc()
                self._metrics.seconds.labels(scope["method"], route).observe(time.perf_counter() - start)
            await send(message)

        await self._application(scope, receive, counted)


def install(application: FastAPI, context: Context) -> None:
    """Measure every request of `application`, and answer GET /metrics."""
    metrics = Metrics(context)
    application.add_middleware(Measured, metrics=metrics)

    @application.get(
        "/metrics",
        tags=["service"],
        response_class=Response,
        responses={200: {"content": {"text/plain": {"example": 'csgmesh_jobs{state="queued"} 0.0\n'}}}},
    )
    def metrics_text(_context: Ctx) -> Response:
        """Requests, jobs, workers, models and meshes, as Prometheus reads them."""
        return Response(generate_latest(metrics.registry), media_type=CONTENT_TYPE_LATEST)
