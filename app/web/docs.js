// The operations that openapi.json describes, as a page: no other server is asked for anything.

const METHODS = ["get", "post", "put", "patch", "delete"];

function element(tag, text = "", ...children) {
  const made = document.createElement(tag);
  made.textContent = text;
  made.append(...children);
  return made;
}

function typeOf(schema) {
  if (schema.$ref) return schema.$ref.split("/").pop();
  if (schema.enum) return schema.enum.map((value) => JSON.stringify(value)).join(" | ");
  if (schema.const !== undefined) return JSON.stringify(schema.const);
  if (schema.anyOf) return schema.anyOf.map(typeOf).join(" | ");
  if (schema.type === "array") return `${typeOf(schema.items ?? {})}[]`;
  return schema.type ?? "any";
}

// Rows of name, type and default, and description.
function table(rows) {
  const body = element("tbody");
  for (const row of rows) body.append(element("tr", "", ...row.map((text) => element("td", text))));
  return element("table", "", body);
}

function typed(schema) {
  return typeOf(schema) + (schema.default === undefined ? "" : `, default ${JSON.stringify(schema.default)}`);
}

function parameters(operation) {
  return (operation.parameters ?? []).map((p) => [p.name, `${p.in}: ${typed(p.schema)}`, p.description ?? ""]);
}

function fields(schema, schemas) {
  const described = schema.$ref ? schemas[typeOf(schema)] : schema;
  return Object.entries(described.properties ?? {}).map(([name, field]) => [name, typed(field), field.description ?? ""]);
}

function example(content) {
  const shown = content.example ?? Object.values(content.examples ?? {})[0]?.value ?? content.schema?.examples?.[0];
  if (shown === undefined) return [];
  return [element("pre", typeof shown === "string" ? shown : JSON.stringify(shown, null, 1))];
}

function operationOf(path, method, operation, schemas) {
  const title = element("summary", "", element("code", `${method.toUpperCase()} ${path}`));
  title.append(` ${(operation.description ?? operation.summary ?? "").split("\n")[0]}`);
  const made = element("details", "", title);
  made.append(element("p", operation.description ?? ""));
  const given = parameters(operation);
  if (given.length) made.append(element("h3", "Parameters"), table(given));
  for (const [type, content] of Object.entries(operation.requestBody?.content ?? {})) {
    made.append(element("h3", `Body, ${type}`), table(fields(content.schema ?? {}, schemas)), ...example(content));
  }
  for (const [status, answer] of Object.entries(operation.responses)) {
    made.append(element("h3", `${status}: ${answer.description}`));
    for (const [type, content] of Object.entries(answer.content ?? {})) {
      made.append(element("p", `${type}${content.schema ? `: ${typeOf(content.schema)}` : ""}`), ...example(content));
    }
  }
  return made;
}

async function show() {
  const answer = await fetch("/openapi.json");
  if (!answer.ok) throw new Error(`openapi.json: ${answer.status} ${answer.statusText}`);
  const described = await answer.json();
  const sections = new Map();
  for (const [path, operations] of Object.entries(described.paths)) {
    for (const method of METHODS.filter((name) => operations[name])) {
      const tag = operations[method].tags?.[0] ?? "other";
      if (!sections.has(tag)) sections.set(tag, element("section", "", element("h2", tag)));
      sections.get(tag).append(operationOf(path, method, operations[method], described.components?.schemas ?? {}));
    }
  }
  document.getElementById("operations").replaceChildren(...sections.values());
}

show().catch((error) => {
  const message = document.getElementById("message");
  message.textContent = error.message;
  message.hidden = false;
});
