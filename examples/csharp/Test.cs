// Opens a figure, plays its clip, and prints where its points go: Test.exe FIGURE CLIP.
using System;
using System.IO;

static class Test
{
    static int Main(string[] arguments)
    {
        if (arguments.Length != 2)
        {
            Console.Error.WriteLine("usage: Test.exe FIGURE CLIP");
            return 2;
        }
        byte[] bytes = File.ReadAllBytes(arguments[0]);
        using (var figure = new Cageform.Figure(bytes))
        using (var player = figure.Play(arguments[1]))
        {
            var vertices = new float[3 * figure.Vertices];
            var pose = new float[3 * figure.Handles];
            var points = new float[3 * figure.Points];
            var normals = figure.HasNormals ? new float[3 * figure.Points] : null;
            Console.WriteLine("{0} points, {1} handles, from {2} s to {3} s", figure.Points, figure.Handles, player.Begin, player.End);
            figure.Rest(pose);
            figure.Clone(pose, points, normals);
            Print("at rest", points);
            for (int frame = 0; frame <= 4; ++frame)
            {
                double time = player.Begin + (player.End - player.Begin) * frame / 4;
                player.Sample(time, vertices);
                figure.PoseHandles(vertices, pose);
                figure.Clone(pose, points, normals);
                Print(time.ToString("F2") + " s", points);
            }
            long before = GC.GetTotalMemory(true);
            for (int frame = 0; frame < 10000; ++frame)
            {
                player.Sample(frame * 0.01, vertices);
                figure.PoseHandles(vertices, pose);
                figure.Clone(pose, points, normals);
            }
            Console.WriteLine("10,000 frames: {0}", GC.GetTotalMemory(true) - before < 4096 ? "memory as before" : "memory grew");
        }
        try
        {
            bytes[bytes.Length / 2] ^= 1;
            new Cageform.Figure(bytes);
        }
        catch (Cageform.CageformException error)
        {
            Console.WriteLine("a spoilt file: {0}", error.Message);
            return 0;
        }
        return 1;
    }

    static void Print(string when, float[] points)
    {
        double x = 0, y = 0, z = 0;
        for (int n = 0; n < points.Length; n += 3)
        {
            x += points[n];
            y += points[n + 1];
            z += points[n + 2];
        }
        int count = points.Length / 3;
        Console.WriteLine("{0}: the mean is {1:F3} {2:F3} {3:F3}", when, x / count, y / count, z / count);
    }
}
