// The page: opens a model, shows its tree, segments and reasons, takes overrides, meshes and hands out decks.
import { EXAMPLES } from "/web/examples.js";
import { rulesEditor } from "/web/rules.js";
import { Viewer, parseGlb } from "/web/viewer.js";

const TYPES = ["beam", "plate", "cylinder_plate", "brick", "plates", "split", "auto"];
const byId = (id) => document.getElementById(id);
const state = { model: null, tree: [], segments: null, decisions: [], overrides: [], node: null, job: null, mesh: null, view: "solid" };
const viewer = new Viewer(byId("viewer"), (name) => {
  const segment = state.segments?.segments.find((s) => s.id === name);
  if (segment) chooseNode(segment.node, segment.id); else chooseNode(null, null);
});

// An element with attributes, properties and children.
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

const shown = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value));
const plural = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;
const basePath = (node) => node.split("#")[0];
const address = (node) => encodeURIComponent(basePath(node));

function tell(message) {
  byId("message").textContent = message || "";
  byId("message").hidden = !message;
}

// A request whose failure is an Error with the service's own message; where the service wants a token, asks for it first.
async function ask(method, path, body, type = "application/json") {
  const options = { method };
  if (body !== undefined) Object.assign(options, { body, headers: { "Content-Type": type } });
  let answer = await fetch(path, options);
  if (answer.status === 401) {
    await giveToken();
    answer = await fetch(path, options);
  }
  if (answer.ok) return answer;
  const problem = await answer.json().catch(() => ({}));
  throw new Error(problem.detail || `${answer.status} ${answer.statusText}`);
}

const askJson = async (method, path, body) => (await ask(method, path, body && JSON.stringify(body))).json();

// Asks for a token until the service takes one and keeps it as a cookie; the same question for all who wait.
let tokenGiven = null;
function giveToken() {
  tokenGiven ??= new Promise((resolve) => {
    const dialog = byId("token-dialog");
    dialog.addEventListener("cancel", (event) => event.preventDefault());
    byId("token-form").onsubmit = async (event) => {
      event.preventDefault();
      const body = JSON.stringify({ token: byId("token").value.trim() });
      const answer = await fetch("/v1/session", { method: "POST", body, headers: { "Content-Type": "application/json" } });
      byId("token-message").hidden = answer.ok;
      byId("token-message").textContent = answer.ok ? "" : "The service does not know this token, or it holds no longer.";
      if (!answer.ok) return;
      byId("token").value = "";
      dialog.close();
      tokenGiven = null;
      resolve();
    };
    dialog.showModal();
  });
  return tokenGiven;
}

// Run an action; whatever goes wrong in it is told on the page.
async function attempt(action) {
  tell("");
  document.body.setAttribute("aria-busy", "true");
  try {
    return await action();
  } catch (error) {
    tell(error.message);
    return undefined;
  } finally {
    document.body.removeAttribute("aria-busy");
  }
}

async function openModel(name, text) {
  const type = name.toLowerCase().endsWith(".json") ? "application/json" : "text/plain";
  await showModel(await (await ask("POST", `/v1/models?name=${encodeURIComponent(name)}`, text, type)).json());
}

async function showModel(kept) {
  endJob();
  Object.assign(state, { model: kept, segments: null, decisions: [], overrides: [], node: null, mesh: null, view: "segments" });
  byId("viewer-hint").hidden = true;
  byId("model-name").textContent = `${kept.name} (${kept.units})`;
  byId("mesh-result").hidden = true;
  byId("job-text").textContent = "";
  viewer.select(null);
  history.replaceState(null, "", `?model=${kept.id}`);
  const tree = await askJson("GET", `/v1/models/${kept.id}/tree`);
  state.tree = flatten(tree.root);
  showTree();
  await loadSegments();
  await showView(true);
}

// The tree as rows [{path, depth, kind, name}].
function flatten(node, path = "/", depth = 0) {
  const row = { path, depth, kind: node.kind, name: node.name };
  const below = (node.operands || []).flatMap((operand, k) => flatten(operand, path === "/" ? `${k}` : `${path}.${k}`, depth + 1));
  return [row, ...below];
}

function showTree() {
  byId("csg-tree").replaceChildren(...state.tree.map((row) => {
    const label = `${row.path} ${row.name ? `${row.name}: ` : ""}${row.kind}`;
    const button = make("button", { type: "button", role: "treeitem", "aria-selected": "false", "data-node": row.path, style: `padding-left: ${0.3 + row.depth}rem`, onclick: () => chooseNode(row.path, null) }, label);
    return make("li", { role: "none" }, button);
  }));
}

async function loadSegments() {
  const path = `/v1/models/${state.model.id}`;
  state.segments = await askJson("GET", `${path}/segments`);
  [state.decisions, state.overrides] = await Promise.all([
    askJson("GET", `${path}/explanation`).then((explained) => explained.decisions),
    askJson("GET", `${path}/overrides`),
  ]);
  showSegments();
  byId("mesh-button").disabled = false;
}

function showSegments() {
  const { segments, joints, volume, units } = state.segments;
  byId("segments").replaceChildren(...segments.map(segmentRow));
  const pinned = state.overrides.length ? `; ${plural(state.overrides.length, "override")}` : "";
  byId("segment-summary").textContent = `${plural(segments.length, "segment")}, ${plural(joints.length, "joint")}, volume ${shown(volume)} ${units}³${pinned}`;
  chooseNode(state.node, null);
}

function segmentRow(segment) {
  const measures = ["thickness", "length", "radius", "holes"].filter((name) => segment[name]).map((name) => `${name} ${shown(segment[name])}`);
  if (segment.section) measures.push(`section ${segment.section.shape}, A ${shown(segment.section.area)}`);
  const decision = segment.decision;
  const because = segment.origin === "override" ? `override; the rules say ${decision.by_rule}: ${decision.because}` : decision.because;
  const row = make("tr", { "data-testid": "segment-row", "data-node": segment.node, "data-type": segment.type, "data-segment": segment.id },
    make("td", {}, make("span", { class: "swatch" })),
    make("td", {}, segment.id),
    make("td", {}, segment.name ? `${segment.node} ${segment.name}` : segment.node),
    make("td", {}, typeSelect(segment.node, segment.type, "segment-type")),
    make("td", {}, measures.join(", ")),
    make("td", { class: "number" }, shown(segment.volume)),
    make("td", {}, because));
  row.addEventListener("click", (event) => { if (event.target.tagName !== "SELECT") chooseNode(segment.node, segment.id); });
  return row;
}

// The select that overrides a node; `auto` gives it back to the rules.
function typeSelect(node, current, testid) {
  const select = make("select", { "aria-label": `Type of node ${node}` });
  if (testid) select.setAttribute("data-testid", testid);
  for (const type of TYPES) {
    const option = make("option", { value: type }, type === "auto" ? "auto (by the rules)" : type.replace("_", " "));
    option.selected = type === current;
    select.append(option);
  }
  if (!TYPES.includes(current)) select.prepend(make("option", { value: "", selected: "" }, current || ""));
  select.addEventListener("change", async () => {
    const isDone = await attempt(async () => {
      await askJson("PUT", `/v1/models/${state.model.id}/overrides/${address(node)}`, { type: select.value, reason: "chosen on the page" });
      forgetMesh();
      await loadSegments();
      await showView(false);
      return true;
    });
    if (!isDone) select.value = current;
  });
  return select;
}

function chooseNode(node, segment) {
  state.node = node;
  for (const button of byId("csg-tree").querySelectorAll("button")) {
    button.setAttribute("aria-selected", String(node !== null && button.dataset.node === basePath(node)));
  }
  const chosen = segment || state.segments?.segments.find((s) => s.node === node)?.id || null;
  for (const row of byId("segments").children) row.classList.toggle("selected", row.dataset.segment === chosen);
  viewer.select(state.view === "solid" ? null : chosen);
  explain(node);
}

function explain(node) {
  const panel = byId("explanation");
  if (node === null) {
    panel.replaceChildren(make("p", { class: "quiet" }, "Choose a node or a segment."));
    return;
  }
  const own = state.decisions.filter((d) => d.node === node);
  const decisions = own.length ? own : state.decisions.filter((d) => basePath(d.node) === basePath(node));
  const pinned = state.overrides.find((o) => o.node === basePath(node));
  const parts = [make("p", {}, make("label", {}, `Decide node ${basePath(node)} yourself: `, typeSelect(node, pinned ? pinned.type : "auto", null)))];
  if (!decisions.length) parts.push(make("p", { class: "quiet" }, "The rules were not asked about this node: a node above it decided."));
  for (const decision of decisions) {
    parts.push(make("p", {}, make("strong", {}, `${decision.node}: ${decision.type.replace("_", " ")}`), ` (${decision.because_of})`));
    parts.push(make("p", {}, `${decision.because} (rule ${decision.rule}, certainty ${shown(decision.certainty)})`));
    if (decision.review) parts.push(make("p", { class: "bad" }, "Close to a threshold: review this one."));
    for (const rejected of decision.rejected) parts.push(make("p", { class: "quiet" }, `not ${rejected.type.replace("_", " ")}: ${rejected.because} (${rejected.rule})`));
    for (const conflict of decision.conflicts) parts.push(make("p", { class: "quiet" }, `conflict: ${conflict}`));
    const rows = Object.entries(decision.facts).map(([name, value]) => make("tr", {}, make("td", {}, name.replaceAll("_", " ")), make("td", {}, shown(value))));
    parts.push(make("details", {}, make("summary", {}, plural(rows.length, "fact")), make("table", {}, make("tbody", {}, ...rows))));
  }
  panel.replaceChildren(...parts);
}

async function showView(fit) {
  for (const tab of document.querySelectorAll("[role=tab]")) {
    tab.setAttribute("aria-selected", String(tab.dataset.view === state.view));
    if (tab.dataset.view === "mesh") tab.disabled = !state.mesh;
  }
  byId("by-quality-label").hidden = state.view !== "mesh";
  const byQuality = state.view === "mesh" && byId("by-quality").checked;
  byId("quality-legend").hidden = !byQuality;
  if (!state.model) return;
  const model = `/v1/models/${state.model.id}`;
  const paths = { solid: `${model}/solid.glb`, segments: `${model}/segments.glb`, mesh: state.mesh && `/v1/meshes/${state.mesh.id}/mesh.glb${byQuality ? "?colour=quality" : ""}` };
  const parts = parseGlb(await (await ask("GET", paths[state.view])).arrayBuffer());
  viewer.show(parts, fit);
  if (byQuality) showLegend(parts);
  if (state.view === "solid" || byQuality) return;
  for (const swatch of document.querySelectorAll("[data-coupling]")) {
    const part = state.view === "mesh" && parts.find((p) => p.name === `${swatch.dataset.coupling} edges`);
    if (part) swatch.style.background = css(part.colour);
  }
  for (const row of byId("segments").children) {
    const part = parts.find((p) => p.name === row.dataset.segment);
    if (part) row.querySelector(".swatch").style.background = css(part.colour);
  }
}

// The parts are named `s1 0.9`: a segment, and from where on the scaled Jacobians lie that have this colour.
function showLegend(parts) {
  const colours = {};
  for (const part of parts) {
    const from = part.name.split(" ")[1];
    if (!part.isLines && from !== undefined) colours[from] = part.colour;
  }
  const swatch = (colour) => make("span", { class: "swatch", style: `background: ${css(colour)}` });
  const found = Object.entries(colours).sort(([a], [b]) => b - a);
  byId("quality-legend").replaceChildren("scaled Jacobian from: ", ...found.flatMap(([from, colour]) => [swatch(colour), ` ${from} `]));
}

const css = (colour) => `rgb(${colour.slice(0, 3).map((v) => Math.round(255 * v)).join(" ")})`;

function forgetMesh() {
  state.mesh = null;
  byId("mesh-result").hidden = true;
  byId("job-text").textContent = "";
  if (state.view === "mesh") state.view = "segments";
}

// What stands in a field, null where nothing does; what the number may be is the service's to say.
function typedNumber(id, what) {
  const text = byId(id).value.trim().replace(",", ".");
  const value = text === "" ? null : Number(text);
  if (Number.isNaN(value)) throw new Error(`${what}: '${text}', expected a number`);
  return value;
}

async function startMesh() {
  const job = await askJson("POST", `/v1/models/${state.model.id}/meshes`, {
    size: typedNumber("mesh-size", "the element size"), per_circle: typedNumber("mesh-per-circle", "the elements round a circle"), layers: typedNumber("mesh-layers", "the layers"),
    order: Number(byId("mesh-order").value), faces: byId("mesh-faces").value, volumes: byId("mesh-volumes").value, coupling: byId("mesh-coupling").value, tee: byId("mesh-tee").value,
    units: byId("mesh-units").value || null, material: byId("mesh-material").value.trim() || null,
  });
  forgetMesh();
  const events = new EventSource(`/v1/jobs/${job.id}/events`);
  state.job = { id: job.id, events };
  showJob(job);
  for (const name of ["progress", "done", "failed", "cancelled"]) {
    events.addEventListener(name, (event) => attempt(() => followJob(JSON.parse(event.data))));
  }
}

async function followJob(job) {
  showJob(job);
  if (!["done", "failed", "cancelled"].includes(job.state)) return;
  endJob();
  if (job.state === "failed") throw new Error(job.problem.detail);
  if (job.state !== "done") return;
  state.mesh = await askJson("GET", `/v1/meshes/${job.mesh_id}`);
  state.view = "mesh";
  showMesh();
  await showView(false);
}

function showJob(job) {
  byId("job-bar").hidden = false;
  byId("job-bar").value = job.progress;
  byId("job-text").textContent = job.state === "running" ? `${job.stage || "starting"} ${Math.round(100 * job.progress)} %` : job.state;
  byId("cancel-button").hidden = false;
  byId("mesh-button").disabled = true;
}

function endJob() {
  state.job?.events.close();
  state.job = null;
  byId("job-bar").hidden = true;
  byId("cancel-button").hidden = true;
  byId("mesh-button").disabled = !state.segments;
}

function showMesh() {
  const mesh = state.mesh;
  const elements = Object.entries(mesh.elements).map(([kind, count]) => `${count} ${kind}`).join(", ");
  const couplings = Object.entries(mesh.couplings).flatMap(([kind, count], k) => [k ? ", " : "", make("span", { class: "swatch", "data-coupling": kind }), ` ${count} ${kind}`]);
  const error = Number((100 * mesh.mass.error).toFixed(2)) || 0;
  const lines = [
    make("p", {}, `${plural(mesh.nodes, "node")}, ${elements}; couplings: `, ...(couplings.length ? couplings : ["none"]), `; ${plural(mesh.components, "component")}`),
    make("p", {}, `mass ${shown(mesh.mass.model)}, of the solid ${shown(mesh.mass.solid)} (${error} %)`),
    qualityTable(mesh.quality),
  ];
  for (const [segment, how] of Object.entries(mesh.bricks)) lines.push(make("p", { class: "quiet" }, `${segment}: ${how}`));
  for (const failure of mesh.checks.failures || []) lines.push(make("p", { class: "bad" }, failure));
  for (const warning of mesh.warnings) lines.push(make("p", { class: "quiet" }, warning));
  byId("quality-summary").replaceChildren(...lines);
  byId("mesh-result").hidden = false;
  linkDeck();
}

// What matters most of each kind: how good the worst ones are.
function qualityTable(quality) {
  const columns = [["scaled_jacobian", "min", "least scaled Jacobian"], ["scaled_jacobian", "p5", "5 % below"], ["min_angle", "min", "least angle"], ["max_angle", "max", "largest angle"], ["aspect", "max", "largest aspect"]];
  const rows = Object.entries(quality).filter(([, measures]) => measures.scaled_jacobian).map(([kind, measures]) => make("tr", {},
    make("td", {}, kind),
    ...columns.map(([measure, which]) => make("td", { class: "number" }, measures[measure] ? shown(Number(measures[measure][which].toPrecision(3))) : ""))));
  if (!rows.length) return make("p", { class: "quiet" }, "Line elements only.");
  const head = make("tr", {}, make("th", {}, "Elements"), ...columns.map(([, , title]) => make("th", { class: "number" }, title)));
  return make("table", { class: "figures" }, make("thead", {}, head), make("tbody", {}, ...rows));
}

function linkDeck() {
  if (state.mesh) byId("download-deck").href = `/v1/meshes/${state.mesh.id}/deck?format=${byId("deck-format").value}`;
}

byId("open-model").addEventListener("change", (event) => attempt(async () => {
  const file = event.target.files[0];
  event.target.value = "";
  byId("example-select").value = "";
  if (file) await openModel(file.name, file);
}));
byId("example-select").append(...Object.keys(EXAMPLES).map((name) => make("option", { value: name }, name)));
byId("example-select").addEventListener("change", (event) => attempt(async () => {
  if (event.target.value) await openModel(...EXAMPLES[event.target.value]);
}));
byId("mesh-form").addEventListener("submit", (event) => { event.preventDefault(); attempt(startMesh); });
byId("cancel-button").addEventListener("click", () => attempt(() => ask("DELETE", `/v1/jobs/${state.job.id}`)));
byId("by-quality").addEventListener("change", () => attempt(() => showView(false)));
byId("deck-format").addEventListener("change", linkDeck);
for (const tab of document.querySelectorAll("[role=tab]")) {
  tab.addEventListener("click", () => attempt(async () => { state.view = tab.dataset.view; await showView(!viewer.parts.length); }));
}
const showRules = rulesEditor({ byId, make, plural, askJson, attempt }, () => state.model, async () => {
  if (state.model) await showModel(state.model);
});
attempt(async () => {
  const formats = await askJson("GET", "/v1/formats");
  byId("deck-format").append(...formats.map((format) => make("option", { value: format.name }, format.title)));
  const model = new URLSearchParams(location.search).get("model");
  if (model) await showModel(await askJson("GET", `/v1/models/${encodeURIComponent(model)}`));
  await showRules();
});
