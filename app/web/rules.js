// The rules' editor: an analyst's text, what is wrong with it as it is written, what it would change, and its use.

const STARTER = `name: our-office
extends: base
parameters:
  beam_slenderness: {value: 10}
`;
const WAIT = 400; // ms without a key before the text is looked at

// parts: {byId, make, plural, askJson, attempt}, as the page has them. openModel(): the model that is open, or null.
// onUse(): called when other rules decide from now on.
export function rulesEditor({ byId, make, plural, askJson, attempt }, openModel, onUse) {
  const editor = byId("rules-editor");
  let versions = [];
  let asked = 0;

  const active = () => versions.find((version) => version.is_active);
  const title = (version) => `${version.name} ${version.version}${version.is_active ? ", in use" : ""}`;
  const path = (version) => `/v1/rulebases/${encodeURIComponent(version.name)}/versions/${encodeURIComponent(version.version)}`;

  function showVersions(list, chosen) {
    versions = list;
    byId("rules-version").replaceChildren(...list.map((version, k) => make("option", { value: k }, title(version))));
    byId("rules-version").value = String(list.indexOf(chosen ?? active()));
    byId("rules-in-use").textContent = `${title(active()).replace(", in use", "")} decides.`;
  }

  async function show(version) {
    const kept = await askJson("GET", path(version));
    const isOwn = version.name === "base";
    editor.value = isOwn ? STARTER : kept.text;
    if (isOwn) byId("rules-base").textContent = kept.text;
    clear();
    await check();
  }

  function clear() {
    byId("rules-diff").replaceChildren();
  }

  // What is wrong with the text; of two answers the later question's counts.
  async function check() {
    const number = ++asked;
    const report = await askJson("POST", "/v1/rulebases/validate", { text: editor.value });
    if (number !== asked) return;
    const own = report.findings.filter((finding) => finding.line !== null && finding.file === "-");
    const notes = report.findings.filter((finding) => !own.includes(finding));
    const rows = own.map((finding) => make("li", { class: finding.severity === "error" ? "bad" : "" },
      make("button", { type: "button", onclick: () => goTo(finding.line, finding.column) }, `${finding.line}:${finding.column}`),
      ` ${finding.message}`));
    if (!own.length) rows.push(make("li", { class: "quiet" }, `${plural(report.rules, "rule")}, nothing wrong with the text.`));
    if (notes.length) {
      rows.push(make("li", {}, make("details", {},
        make("summary", { class: "quiet" }, `${plural(notes.length, "remark")} on the rules as a whole`),
        make("ul", {}, ...notes.map((finding) => make("li", { class: "quiet" }, finding.message))))));
    }
    byId("rules-problems").replaceChildren(...rows);
    for (const button of ["rules-compare", "rules-test", "rules-use"]) byId(button).disabled = !report.ok;
  }

  function goTo(line, column) {
    const lines = editor.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0) + column - 1;
    editor.focus();
    editor.setSelectionRange(start, Math.max(start, lines.slice(0, line).join("\n").length));
  }

  // The text as a version that is kept: the same text twice is the same version.
  async function keep() {
    const kept = await askJson("POST", "/v1/rulebases", { text: editor.value });
    const list = await askJson("GET", "/v1/rulebases");
    showVersions(list, list.find((version) => version.name === kept.name && version.version === kept.version));
    return kept;
  }

  function tell(lines, head, rows) {
    const parts = lines.map((line) => make("p", {}, line));
    if (rows.length) {
      parts.push(make("table", { class: "figures" },
        make("thead", {}, make("tr", {}, ...head.map((text) => make("th", {}, text)))),
        make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((text) => make("td", {}, text)))))));
    }
    byId("rules-diff").replaceChildren(...parts);
  }

  async function compare() {
    const kept = await keep();
    const model = openModel();
    const now = active();
    const against = now.name === "base" ? "base" : `${now.name}@${now.version}`;
    const report = await askJson("POST", `${path(kept)}/diff`, { against, models: model ? [model.id] : [] });
    const of = model ? `decisions in ${model.name}` : "cases of the rules (no model is open)";
    const bare = (node) => (model ? node.slice(`${model.name} ${model.id} `.length) : node);
    tell(
      [`${report.changes.length} of ${report.nodes} ${of} differ from ${title(now).replace(", in use", "")}.`],
      ["Node", "Now", "With this text", "By", "Because"],
      report.changes.map((change) => [bare(change.node), change.before, change.after, change.rule_after, change.because]),
    );
  }

  async function test() {
    const report = await askJson("POST", `${path(await keep())}/test`);
    const failed = report.cases.filter((one) => !one.passed);
    const lines = [`${report.cases.length - failed.length} of ${plural(report.cases.length, "case")} hold.`];
    tell(lines, ["Case", "Rule", "Expected", "Found", ""], failed.map((one) => [one.name, one.rule ?? "", one.expected, one.found, one.message]));
  }

  async function use() {
    const kept = await keep();
    showVersions(await askJson("POST", `${path(kept)}/activate`));
    clear();
    await onUse();
  }

  async function useOwn() {
    showVersions(await askJson("POST", `${path(versions.find((version) => version.name === "base"))}/activate`));
    await show(active());
    await onUse();
  }

  let timer = 0;
  editor.addEventListener("input", () => {
    clear();
    clearTimeout(timer);
    timer = setTimeout(() => attempt(check), WAIT);
  });
  byId("rules-version").addEventListener("change", (event) => attempt(() => show(versions[event.target.value])));
  byId("rules-compare").addEventListener("click", () => attempt(compare));
  byId("rules-test").addEventListener("click", () => attempt(test));
  byId("rules-use").addEventListener("click", () => attempt(use));
  byId("rules-own").addEventListener("click", () => attempt(useOwn));

  return async () => {
    showVersions(await askJson("GET", "/v1/rulebases"));
    byId("rules-base").textContent = (await askJson("GET", path(versions[0]))).text;
    await show(active());
  };
}
