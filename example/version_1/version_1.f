C     A program of version 1 of the Fortran 77 interface. It stays as it
C     is: every later version of the library has to run it with these
C     numbers while GCVINT gives 1.
C
      PROGRAM V1
      IMPLICIT NONE
      INTEGER NVERS, IGRV, ICAS, IFRC, ISIM, IOBS, MJD, ISTAT, NIT, ICNV
      REAL*8 XFIX(3), A(3), U, SEC, DUR, DT, X(13), D(3), AG(3), AD(3)
      REAL*8 AS(3), AE(3), AT(3), SIG(3), COV(3,3), PSIG(3), DIR(3,3)
      REAL*8 CSIG(3), RMS(3), COND
      CHARACTER*400 MSG
      DATA XFIX /4.0D6, -3.0D6, 4.6D6/
C
      CALL GCVINT(NVERS)
      IF (NVERS .NE. 1) STOP 1
      CALL GCGRVO('egm96', 20, 20, IGRV, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCGRAV(IGRV, XFIX, A, U, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'gravity', A, U
      CALL GCCASE('front-3', ICAS, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCCINI(ICAS, MJD, SEC, DUR, DT, X, D, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCFRCO(ICAS, IFRC, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCFORC(IFRC, 0D0, X, X(4), X(10), AG, AD, AS, AE, AT, ISTAT,
     &   MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'total', AT
      CALL GCBND(ICAS, SIG, COV, PSIG, DIR, CSIG, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'sigma', SIG
      CALL GCSIMO(ICAS, ISIM, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCSIMU(ISIM, 1, 1, IOBS, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCESTM('assest-fde', IOBS, D, COV, RMS, COND, NIT, ICNV,
     &   ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'offset', D
      CALL GCFREE(IOBS, ISTAT, MSG)
      CALL GCFREE(ISIM, ISTAT, MSG)
      CALL GCFREE(IFRC, ISTAT, MSG)
      CALL GCFREE(ICAS, ISTAT, MSG)
      CALL GCFREE(IGRV, ISTAT, MSG)
  100 FORMAT (A, 1P, 4E20.12)
      END

      SUBROUTINE CHECK(ISTAT, MSG)
      IMPLICIT NONE
      INTEGER ISTAT
      CHARACTER*(*) MSG
      IF (ISTAT .EQ. 0) RETURN
      WRITE (*, '(A, I2, 2A)') 'status', ISTAT, ': ', MSG
      STOP 1
      END
