# The version the API test is written against.
SCHEMATHESIS := 4.32.5
# What elevation is read with beside ours.
RASTERIO := 1.4.4
PYTHON := .venv/schemathesis-$(SCHEMATHESIS)-rasterio-$(RASTERIO)

.PHONY: run test viewer bench soak

run: viewer # serves the built-in demo city
	cargo run --release -- serve

test: viewer $(PYTHON)
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

# Without python3 there is nothing to install, and both tests say that they are skipped.
$(PYTHON):
	@if ! command -v python3 >/dev/null; then \
		echo "SKIPPED: the tests with schemathesis and with rasterio need python3"; \
	else \
		python3 -m venv .venv && \
		.venv/bin/pip install --quiet --disable-pip-version-check schemathesis==$(SCHEMATHESIS) && \
		{ .venv/bin/pip install --quiet --disable-pip-version-check rasterio==$(RASTERIO) || \
			echo "SKIPPED: the test with rasterio, of which there is none for this machine"; } && \
		touch $@; \
	fi
