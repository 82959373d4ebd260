# The version the API test is written against.
SCHEMATHESIS := 4.32.5

.PHONY: run test viewer bench soak

run: viewer # serves the built-in demo city
	cargo run --release -- serve

test: viewer .venv/schemathesis-$(SCHEMATHESIS)
	cargo test --tests --examples
	cargo test --doc
	@if ! command -v npm >/dev/null; then \
		echo "SKIPPED: the browser test needs Node.js 20.19 or newer"; exit 0; \
	fi; \
	if ! command -v chromium >/dev/null && [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		apt-get -qq update && apt-get -qq install -y --no-install-recommends chromium >/dev/null; \
	fi; \
	command -v chromium >/dev/null || echo "SKIPPED: the browser test needs Chromium"; \
	cd viewer && npm test --silent

# Without Node.js the service shows a page without pictures at /, which says so.
viewer:
	@if ! command -v npm >/dev/null; then \
		echo "SKIPPED: the viewer needs Node.js 20.19 or newer"; \
	else \
		cd viewer && npm ci --silent --no-audit --no-fund && npm run --silent build; \
	fi

# Streams, queries and reloads for half an hour, then a kill; SOAK="--seconds 300" for less.
soak:
	cargo build --release --bin citylod
	cargo run --release --example soak -- $(SOAK)

bench:
	cargo bench

# Without python3 there is nothing to install, and the API test says that it is skipped.
.venv/schemathesis-$(SCHEMATHESIS):
	@if ! command -v python3 >/dev/null; then \
		echo "SKIPPED: the API test with schemathesis needs python3"; \
	else \
		python3 -m venv .venv && \
		.venv/bin/pip install --quiet --disable-pip-version-check schemathesis==$(SCHEMATHESIS) && \
		touch $@; \
	fi
