!> The Fortran 77 entry points as a program of that time sees them: for the compiler, which wants an
!> interface. The arguments are those of the table in docs/api.md.
module f77_entries
    implicit none
    private
    public :: gcvers, gcfree, gcutc, gcuadd, gcudif, gcgmst, gcrotz, gcgrvo, gcgrav, gcgrvn, gcgrad
    public :: gcdenm, gcdnmi
    public :: gcfldo, gcfeld, gcdeno, gcdeni, gcdens, gcwndo, gcwind, gcsun, gcshad, gcerdo
    public :: gcerad, gctrap, gcplat, gcdrag, gcsrp, gcerp, gccase, gccini, gcfrco, gcforc, gcload
    public :: gcrate, gcprop, gcsimo, gcsimu, gcsetr, gcsetm, gcobsr, gcobsw, gcobsn, gcobsc, gcestm
    public :: gcl1es, gcl1dy, gcbnd, gcdsgd, gcdsgn, gcrods, gcmap

    interface
        subroutine gcvers(vers)
            character(*) :: vers
        end subroutine gcvers

        subroutine gcfree(ih, istat, msg)
            character(*) :: msg
            integer :: ih, istat
        end subroutine gcfree

        subroutine gcutc(text, mjd, sec, istat, msg)
            character(*) :: text, msg
            integer :: mjd, istat
            double precision :: sec
        end subroutine gcutc

        subroutine gcuadd(mjd, sec, dt, mjd2, sec2, istat, msg)
            character(*) :: msg
            integer :: mjd, mjd2, istat
            double precision :: sec, dt, sec2
        end subroutine gcuadd

        subroutine gcudif(mjd1, sec1, mjd2, sec2, dt, istat, msg)
            character(*) :: msg
            integer :: mjd1, mjd2, istat
            double precision :: sec1, sec2, dt
        end subroutine gcudif

        subroutine gcgmst(mjd, sec, dut1, theta, istat, msg)
            character(*) :: msg
            integer :: mjd, istat
            double precision :: sec, dut1, theta
        end subroutine gcgmst

        subroutine gcrotz(theta, xinr, xfix, istat, msg)
            character(*) :: msg
            integer :: istat
            double precision :: theta, xinr(3), xfix(3)
        end subroutine gcrotz

        subroutine gcgrvo(name, ndeg, nord, igrv, istat, msg)
            character(*) :: name, msg
            integer :: ndeg, nord, igrv, istat
        end subroutine gcgrvo

        subroutine gcgrav(igrv, xfix, a, u, istat, msg)
            character(*) :: msg
            integer :: igrv, istat
            double precision :: xfix(3), a(3), u
        end subroutine gcgrav

        subroutine gcgrvn(igrv, n, xfix, a, u, istat, msg)
            integer :: igrv, n, istat
            double precision :: xfix(3, *), a(3, *), u(*)
            character(*) :: msg
        end subroutine gcgrvn

        subroutine gcgrad(igrv, xfix, g, istat, msg)
            character(*) :: msg
            integer :: igrv, istat
            double precision :: xfix(3), g(3, 3)
        end subroutine gcgrad

        subroutine gcfldo(name, mjd, sec, ifld, istat, msg)
            character(*) :: name, msg
            integer :: mjd, ifld, istat
            double precision :: sec
        end subroutine gcfldo

        subroutine gcfeld(ifld, xfix, b, istat, msg)
            character(*) :: msg
            integer :: ifld, istat
            double precision :: xfix(3), b(3)
        end subroutine gcfeld

        subroutine gcdeno(mjd, sec, iden, istat, msg)
            character(*) :: msg
            integer :: mjd, iden, istat
            double precision :: sec
        end subroutine gcdeno

        subroutine gcdeni(f107, f107a, xkp, iden, istat, msg)
            character(*) :: msg
            integer :: iden, istat
            double precision :: f107, f107a, xkp
        end subroutine gcdeni

        subroutine gcdenm(name, mjd, sec, iden, istat, msg)
            character(*) :: name, msg
            integer :: mjd, iden, istat
            double precision :: sec
        end subroutine gcdenm

        subroutine gcdnmi(name, f107, f107a, xkp, iden, istat, msg)
            character(*) :: name, msg
            integer :: iden, istat
            double precision :: f107, f107a, xkp
        end subroutine gcdnmi

        subroutine gcdens(iden, mjd, sec, xfix, rho, temp, xn, istat, msg)
            character(*) :: msg
            integer :: iden, mjd, istat
            double precision :: sec, xfix(3), rho, temp, xn(3)
        end subroutine gcdens

        subroutine gcwndo(name, iwnd, istat, msg)
            character(*) :: name, msg
            integer :: iwnd, istat
        end subroutine gcwndo

        subroutine gcwind(iwnd, mjd, sec, xfix, weast, wnorth, istat, msg)
            character(*) :: msg
            integer :: iwnd, mjd, istat
            double precision :: sec, xfix(3), weast, wnorth
        end subroutine gcwind

        subroutine gcsun(mjd, sec, xsun, istat, msg)
            character(*) :: msg
            integer :: mjd, istat
            double precision :: sec, xsun(3)
        end subroutine gcsun

        subroutine gcshad(x, xsun, xnu, istat, msg)
            character(*) :: msg
            integer :: istat
            double precision :: x(3), xsun(3), xnu
        end subroutine gcshad

        subroutine gcerdo(name, nrings, e0, ierd, istat, msg)
            character(*) :: name, msg
            integer :: nrings, ierd, istat
            double precision :: e0
        end subroutine gcerdo

        subroutine gcerad(ierd, mjd, sec, xinr, flux, istat, msg)
            character(*) :: msg
            integer :: ierd, mjd, istat
            double precision :: sec, xinr(3), flux(3)
        end subroutine gcerad

        subroutine gctrap(xlen, high, wbot, wtop, spec, diff, isur, istat, msg)
            character(*) :: msg
            integer :: isur, istat
            double precision :: xlen, high, wbot, wtop, spec, diff
        end subroutine gctrap

        subroutine gcplat(n, xnrm, area, cen, spec, diff, isur, istat, msg)
            character(*) :: msg
            integer :: n, isur, istat
            double precision :: xnrm(3, *), area(*), cen(3, *), spec(*), diff(*)
        end subroutine gcplat

        subroutine gcdrag(isur, xmass, cd, rho, v, a, istat, msg)
            character(*) :: msg
            integer :: isur, istat
            double precision :: xmass, cd, rho, v(3), a(3)
        end subroutine gcdrag

        subroutine gcsrp(isur, xmass, eta, e0, xnu, tosun, a, istat, msg)
            character(*) :: msg
            integer :: isur, istat
            double precision :: xmass, eta, e0, xnu, tosun(3), a(3)
        end subroutine gcsrp

        subroutine gcerp(isur, xmass, eta, flux, xinr, q, a, istat, msg)
            character(*) :: msg
            integer :: isur, istat
            double precision :: xmass, eta, flux(3), xinr(3), q(4), a(3)
        end subroutine gcerp

        subroutine gccase(name, icas, istat, msg)
            character(*) :: name, msg
            integer :: icas, istat
        end subroutine gccase

        subroutine gccini(icas, mjd, sec, dur, dt, x, d, istat, msg)
            character(*) :: msg
            integer :: icas, mjd, istat
            double precision :: sec, dur, dt, x(13), d(3)
        end subroutine gccini

        subroutine gcfrco(icas, ifrc, istat, msg)
            character(*) :: msg
            integer :: icas, ifrc, istat
        end subroutine gcfrco

        subroutine gcforc(ifrc, t, x, v, q, agrv, adrg, asun, aerd, atot, istat, msg)
            character(*) :: msg
            integer :: ifrc, istat
            double precision :: t, x(3), v(3), q(4), agrv(3), adrg(3), asun(3), aerd(3), atot(3)
        end subroutine gcforc

        subroutine gcload(ifrc, t, x, torq, b, istat, msg)
            character(*) :: msg
            integer :: ifrc, istat
            double precision :: t, x(13), torq(3, 4), b(3)
        end subroutine gcload

        subroutine gcrate(ifrc, t, x, xdot, istat, msg)
            character(*) :: msg
            integer :: ifrc, istat
            double precision :: t, x(13), xdot(13)
        end subroutine gcrate

        subroutine gcprop(ifrc, x, dt, n, xout, istat, msg)
            character(*) :: msg
            integer :: ifrc, n, istat
            double precision :: x(13), dt, xout(13, *)
        end subroutine gcprop

        subroutine gcsimo(icas, isim, istat, msg)
            character(*) :: msg
            integer :: icas, isim, istat
        end subroutine gcsimo

        subroutine gcsimu(isim, iseed, irun, iobs, istat, msg)
            character(*) :: msg
            integer :: isim, iseed, irun, iobs, istat
        end subroutine gcsimu

        subroutine gcsetr(file, iset, istat, msg)
            character(*) :: file, msg
            integer :: iset, istat
        end subroutine gcsetr

        subroutine gcsetm(iset, n, t, xm, isetm, istat, msg)
            character(*) :: msg
            integer :: iset, n, isetm, istat
            double precision :: t(*), xm(3, *)
        end subroutine gcsetm

        subroutine gcobsr(dir, iobs, istat, msg)
            character(*) :: dir, msg
            integer :: iobs, istat
        end subroutine gcobsr

        subroutine gcobsw(iobs, dir, istat, msg)
            character(*) :: dir, msg
            integer :: iobs, istat
        end subroutine gcobsw

        subroutine gcobsn(iobs, n, istat, msg)
            character(*) :: msg
            integer :: iobs, n(4), istat
        end subroutine gcobsn

        subroutine gcobsc(iset, na, ta, a, ns, ts, ihead, q, nm, tm, b, no, to, xo, iobs, istat, msg)
            character(*) :: msg
            integer :: iset, na, ns, ihead(*), nm, no, iobs, istat
            double precision :: ta(*), a(3, *), ts(*), q(4, *), tm(*), b(3, *), to(*), xo(3, *)
        end subroutine gcobsc

        subroutine gcl1es(dir, setup, sat, src, d, cov, gain, delay, iflag, istat, msg)
            character(*) :: dir, setup, sat, src, msg
            integer :: iflag(2), istat
            double precision :: d(3), cov(3, 3), gain(3), delay(2)
        end subroutine gcl1es

        subroutine gcl1dy(dir, setup, sat, day, src, d, cov, gain, delay, iflag, istat, msg)
            character(*) :: dir, setup, sat, day, src, msg
            integer :: iflag(2), istat
            double precision :: d(3), cov(3, 3), gain(3), delay(2)
        end subroutine gcl1dy

        subroutine gcestm(algo, iobs, d, cov, rms, cond, niter, iconv, istat, msg)
            character(*) :: algo, msg
            integer :: iobs, niter, iconv, istat
            double precision :: d(3), cov(3, 3), rms(3), cond
        end subroutine gcestm

        subroutine gcbnd(icas, sig, cov, psig, dir, csig, istat, msg)
            character(*) :: msg
            integer :: icas, istat
            double precision :: sig(3), cov(3, 3), psig(3), dir(3, 3), csig(3)
        end subroutine gcbnd

        subroutine gcdsgd(icas, opt, iopt, istat, msg)
            character(*) :: msg
            integer :: icas, iopt(8), istat
            double precision :: opt(9)
        end subroutine gcdsgd

        subroutine gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
            character(*) :: msg
            integer :: icas, iopt(8), jcas, istat
            double precision :: opt(9), sig(3), wave(3), frc(3), amot(2)
        end subroutine gcdsgn

        subroutine gcrods(icas, nmax, n, rod, irod, istat, msg)
            character(*) :: msg
            integer :: icas, nmax, n, irod(2, *), istat
            double precision :: rod(7, *)
        end subroutine gcrods

        subroutine gcmap(icas, nplc, t, nthr, plc, sig, wrst, istat, msg)
            character(*) :: msg
            integer :: icas, nplc, nthr, istat
            double precision :: t(*), plc(2, *), sig(3, *), wrst(4, *)
        end subroutine gcmap
    end interface
end module f77_entries
