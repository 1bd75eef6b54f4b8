"""Tokens: made, listed and revoked on the command line; asked for over HTTP once there is one."""

import datetime
import json

import pytest
from fastapi.testclient import TestClient

from app.api.access import COOKIE, is_guarded
from app.api.server import create_app
from app.cli import run
from app.settings import load_settings
from app.store import Store
from app.tokens import PREFIX, create_token, digest_of, revoke_token, state_of
from kernel.errors import OptionError

OPEN = {"/", "/docs", "/openapi.json", "/healthz", "/readyz", "/favicon.ico", "/web", "/v1/session"}


@pytest.fixture
def client(tmp_path):
    with TestClient(create_app(load_settings(data=str(tmp_path), workers=1)), raise_server_exceptions=False) as client:
        yield client


@pytest.fixture
def store(tmp_path):
    store = Store(load_settings(data=str(tmp_path)).database)
    yield store
    store.close()


@pytest.fixture
def token(store):
    return create_token(store, "anna")[0]


def bearer(secret):
    return {"Authorization": f"Bearer {secret}"}


def test_without_tokens_the_service_is_open(client):
    assert client.get("/v1/models").status_code == 200
    assert client.get("/metrics").status_code == 200


def test_once_there_is_a_token_all_that_holds_data_asks_for_one(client, token):
    refused = client.get("/v1/models")
    assert refused.status_code == 401
    assert refused.headers["www-authenticate"] == "Bearer"
    assert refused.headers["content-type"] == "application/problem+json"
    assert "csgmesh token create" in refused.json()["detail"]
    assert client.get("/v1/models", headers=bearer(token)).status_code == 200
    assert client.get("/v1/models", headers={"Authorization": f"bearer {token}"}).status_code == 200
    for wrong in (bearer("x"), bearer(""), {"Authorization": token}, {"Authorization": "Basic " + token}, bearer("é")):
        wrong = {name: value.encode("latin-1") for name, value in wrong.items()}
        assert client.get("/v1/models", headers=wrong).status_code == 401
    assert client.post("/v1/models", content=b"x" * 10).status_code == 401
    assert client.get("/metrics").status_code == 401


def test_no_operation_is_left_unguarded(client):
    for path in client.get("/openapi.json").json()["paths"]:
        assert is_guarded(path) != (path in OPEN), path


def test_what_holds_no_data_stays_open(client, token):
    for path in ("/", "/docs", "/openapi.json", "/healthz", "/readyz", "/web/app.js"):
        assert client.get(path).status_code == 200, path


def test_the_page_gives_its_token_once_and_gets_a_cookie_that_scripts_cannot_read(client, token):
    assert client.post("/v1/session", json={"token": "csgmesh_wrong"}).status_code == 401
    assert COOKIE not in client.cookies
    opened = client.post("/v1/session", json={"token": token})
    assert opened.status_code == 204
    said = opened.headers["set-cookie"].lower()
    assert "httponly" in said and "samesite=strict" in said
    assert client.get("/v1/models").status_code == 200
    assert client.delete("/v1/session").status_code == 204
    assert client.get("/v1/models").status_code == 401


def test_a_revoked_token_opens_nothing_and_leaves_the_service_closed(client, store, token):
    revoke_token(store, "anna")
    assert client.get("/v1/models", headers=bearer(token)).status_code == 401
    assert client.get("/v1/models").status_code == 401
    again, _ = create_token(store, "anna")
    assert client.get("/v1/models", headers=bearer(again)).status_code == 200


def test_an_expired_token_opens_nothing(client, store):
    past = (datetime.datetime.now(datetime.UTC) - datetime.timedelta(seconds=1)).isoformat(timespec="microseconds")
    row = store.add_token("old", digest_of("csgmesh_old"), past)
    assert state_of(row) == "expired"
    assert client.get("/v1/models", headers=bearer("csgmesh_old")).status_code == 401


def test_only_a_hash_is_kept(store, token, tmp_path):
    assert token.startswith(PREFIX)
    store.close()
    assert not any(token.encode() in path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())


def test_a_use_is_noted(client, store, token):
    assert store.tokens()[0].used is None
    client.get("/v1/models", headers=bearer(token))
    used = store.tokens()[0].used
    assert used is not None
    client.get("/v1/models", headers=bearer(token))
    assert store.tokens()[0].used == used  # not again within a minute


def in_thirty_days():
    return datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=30)


def test_tokens_on_the_command_line(client, tmp_path, capsys):
    data = ["--data", str(tmp_path)]
    assert run(["token", "list", *data]) == 0
    assert capsys.readouterr().out.startswith("no tokens: the service is open")
    before = in_thirty_days()
    assert run(["token", "create", "anna", "--days", "30", *data]) == 0
    after = in_thirty_days()
    printed = capsys.readouterr()
    secret = printed.out.strip()
    assert secret.startswith(PREFIX)
    assert "cannot be shown again" in printed.err
    assert client.get("/v1/models", headers=bearer(secret)).status_code == 200
    assert run(["token", "list", "--json", *data]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["name"], row["state"]) == ("anna", "holds")
    assert before <= datetime.datetime.fromisoformat(row["expires"]) <= after
    assert not {"digest", "token"} & set(row)
    assert run(["token", "revoke", row["id"], *data]) == 0
    assert "is revoked" in capsys.readouterr().out
    assert client.get("/v1/models", headers=bearer(secret)).status_code == 401
    assert run(["token", "list", *data]) == 0
    assert "revoked" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["create", " "], "a token's name ' '"),
        (["create", "x" * 101], "expected 1 to 100 letters"),
        (["create", "a\nb"], "a token's name"),
        (["create", "bert", "--days", "0"], "a token for 0 days, expected 1 to 3650"),
        (["create", "anna"], "there is a token 'anna' already"),
        (["revoke", "bert"], "there is no token 'bert' to revoke"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(token, tmp_path, capsys, arguments, said):
    assert run(["token", *arguments, "--data", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_token_is_revoked_once(store, token):
    first = revoke_token(store, "anna").revoked
    assert store.revoke_token(store.tokens()[0].id).revoked == first
    with pytest.raises(OptionError, match="no token 'anna'"):
        revoke_token(store, "anna")
