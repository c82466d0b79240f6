"""Compares what a running planar-console answers with its description in OpenAPI."""
import json
import urllib.error
import urllib.request

SAMPLES = {"n": "1", "x_mm": "300", "y_mm": "100"}  # values of parameters
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": int,
         "null": type(None)}


class Api:
    """The API of a console at this origin, asked with a token."""

    def __init__(self, origin, token):
        self.origin, self.token = origin, token
        self.description = json.loads(self.request("/openapi.json")[1])

    def request(self, path, body=None):
        """Returns status and text of an answer."""
        headers = {"Authorization": f"Bearer {self.token}"}
        if body is not None:
            headers.update({"Content-Type": "application/json", "X-Planar-Client": "0123456789abcdef"})
        data = None if body is None else json.dumps(body).encode()
        try:
            with urllib.request.urlopen(urllib.request.Request(self.origin + path, data, headers), timeout=5) as answer:
                return answer.status, answer.read() if "event-stream" not in answer.headers["Content-Type"] else b""
        except urllib.error.HTTPError as refusal:
            return refusal.code, refusal.read()

    def faults(self):
        """Returns in what the answers differ from the description. Nothing moves, and the cell is given back."""
        found = [f"{method.upper()} {path}: {fault}" for path, methods in self.description["paths"].items()
                 for method, described in methods.items()
                 for fault in (self._get_faults(path, described) if method == "get" else self._post_faults(path, described))]
        self.request("/api/operator", {"take": False})
        return found

    def _get_faults(self, path, described):
        query = []
        for parameter in described.get("parameters", []):
            value = SAMPLES.get(parameter["name"])
            path = path.replace(f"{{{parameter['name']}}}", value or "")
            if parameter["in"] == "query" and parameter["required"]:
                query.append(f"{parameter['name']}={value}")
        status, text = self.request(path + ("?" + "&".join(query) if query else ""))
        if status != 200:
            return [f"answers {status}"]
        content = described["responses"]["200"]["content"]
        return list(self._differences(json.loads(text), content["application/json"]["schema"], "")) \
            if "application/json" in content else []

    def _post_faults(self, path, described):
        """What is needed and missing is refused as described; what needs nothing is left alone, because it acts."""
        schema = described["requestBody"]["content"]["application/json"]["schema"]
        if not schema["required"]:
            return []
        status, text = self.request(path, {})
        refusal = {"$ref": "#/components/schemas/Refusal"}
        return ([] if status == 400 else [f"answers {status} to a body without {schema['required']}"]) + \
            list(self._differences(json.loads(text), refusal, ""))

    def _differences(self, value, schema, where):
        if "$ref" in schema:
            return (yield from self._differences(value, self._named(schema["$ref"]), where))
        if "oneOf" in schema:
            found = [list(self._differences(value, one, where)) for one in schema["oneOf"]]
            if [] not in found:
                yield from min(found, key=len)
            return
        types = schema.get("type", [])
        types = [types] if isinstance(types, str) else types
        if types and not any(isinstance(value, TYPES[name]) for name in types):
            yield f"{where} is {json.dumps(value)}, not {' or '.join(types)}"
        elif "enum" in schema and value not in schema["enum"]:
            yield f"{where} is {json.dumps(value)}, not among {schema['enum']}"
        elif isinstance(value, dict):
            yield from (f"{where} lacks {key}" for key in schema.get("required", []) if key not in value)
            for key, one in schema.get("properties", {}).items():
                if key in value:
                    yield from self._differences(value[key], one, f"{where}.{key}")
        elif isinstance(value, list):
            for i, one in enumerate(value):
                yield from self._differences(one, schema.get("items", {}), f"{where}[{i}]")

    def _named(self, reference):
        found = self.description
        for part in reference.split("/")[1:]:
            found = found[part]
        return found
