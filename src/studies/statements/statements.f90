!> Statements of CSR-TM-00-01 that stand in its text without a table or a figure, examined: each is computed, and
!> its verdict follows from the numbers.
module gracecg_studies_statements
    use gracecg_base_kinds, only: i8
    use gracecg_base_constants, only: MILLIMETRE, ARCSECOND
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t
    use gracecg_base_text, only: join, pick_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_value, only: did_you_mean
    use gracecg_studies_examination, only: claim_t, statement_t, statement_row_t, examination_t, HOLDS, &
        HOLDS_IN_PART, HOLDS_NOT, VERDICT_WORDS, SINGLE_ALGORITHM, COMBINED_ALGORITHM
    use gracecg_studies_manoeuvre_statements, only: examine_one_rod, examine_dominance, examine_arc_length
    use gracecg_studies_estimate_statements, only: examine_weights, examine_accuracy, examine_curved_force, &
        examine_condition, examine_two_steps, examine_stars
    implicit none
    private
    public :: statement_t, statement_row_t, examine_statement, statement_table, STATEMENT_NAMES
    public :: HOLDS, HOLDS_IN_PART, HOLDS_NOT, VERDICT_WORDS

    type(claim_t), parameter :: CLAIMS(9) = [ &
        claim_t('one-rod', 'sections 4.1 and 7.1(1)', 'activating the magnetic dipole moment along only one axis cannot '// &
                'yield good CG calibration accuracy', &
                'one rod of 30 A m^2 at 0.1 Hz in place of the report''s two; '//SINGLE_ALGORITHM), &
        claim_t('dominance', 'section 4.1', 'one axis alone is not good enough since the magnetic torque is no longer the '// &
                'dominating torque, the fitting attitude model is not good enough', &
                'RMS of the rods'' torque over that of the sum of all others; Cramer-Rao bound of d, which knows all '// &
                'torques; condition of the information of d'), &
        claim_t('arc-length', 'section 4.1', 'longer arcs do not yield good results, since the non-gravitational '// &
                'acceleration is no longer linear: 60 s are the trade-off', &
                'the report''s rods for 60 to 300 s; '//SINGLE_ALGORITHM), &
        claim_t('weights', 'section 7.2(1)', 'the estimation accuracy is relatively highly dependent on the weight for the '// &
                'accelerometer data and star cameras data', &
                'weights of the star camera, then of the accelerometer''s axes; '//COMBINED_ALGORITHM), &
        claim_t('accuracy', 'sections 6.2 and 7.1(3)', 'the accuracy can be better than 0.02 mm for x, 0.01 mm for y and '// &
                '0.02 mm for z, in the best chance of each axis', 'the cases of the front satellite; '//COMBINED_ALGORITHM), &
        claim_t('curved-force', 'section 5.3', 'the non-linear non-gravitational acceleration has only a small impact upon '// &
                'the estimation accuracy when it is fitted by the linear function', &
                'drag with the density wave and light as they are, without the wave, and their least-squares line in '// &
                'their place; '//COMBINED_ALGORITHM), &
        claim_t('condition', 'section 4.6.1', 'the full state may cause a singular covariance matrix, since only three of '// &
                'the four quaternion components are independent; in several simulations there is no singular problem', &
                'condition of the attitude''s normal matrix with unit diagonal, exact observations'), &
        claim_t('two-steps', 'section 6.2', 'the calibration can be done in two steps: y and z at one place, x at the other', &
                'Cramer-Rao bounds of the report''s cases, their information added: theory of a joint solution'), &
        claim_t('stars', 'section 3.3.2', 'every frame can contain roughly 70 stars, at least 20 will be observed; an '// &
                'optimal choice of 20 is preferred to increase the accuracy, the first 20 are taken', &
                'stars of the catalogue in the used head''s field; noise of its attitude by QUEST''s covariance, mean over '// &
                'the frames of the arc; the best 20 have the least trace of it')]
    !> The statements, as on the command line
    character(12), parameter :: STATEMENT_NAMES(size(CLAIMS)) = CLAIMS%name

contains

    !> Examines one statement. Fails for a name that is none of STATEMENT_NAMES, and when a run fails.
    subroutine examine_statement(name, runs, seed, threads, statement, error, progress)
        character(*), intent(in) :: name            !! One of STATEMENT_NAMES
        integer, intent(in) :: runs, threads        !! Of each Monte Carlo, 0: theory alone; in parallel
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(statement_t), intent(out) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(examination_t) :: work
        integer :: place

        place = findloc(STATEMENT_NAMES, name, 1)
        if (place == 0) then
            call fail(error, 'no statement "'//trim(name)//'"; there are '//join(STATEMENT_NAMES, ', ')// &
                      did_you_mean(name, STATEMENT_NAMES))
            return
        end if
        work%claim_t = CLAIMS(place)
        work%runs = runs
        work%threads = threads
        work%seed = seed
        allocate (work%rows(0))
        select case (name)
        case ('one-rod')
            call examine_one_rod(work, error, progress)
        case ('dominance')
            call examine_dominance(work, error)
        case ('arc-length')
            call examine_arc_length(work, error, progress)
        case ('weights')
            call examine_weights(work, error, progress)
        case ('accuracy')
            call examine_accuracy(work, error, progress)
        case ('curved-force')
            call examine_curved_force(work, error, progress)
        case ('condition')
            call examine_condition(work, error)
        case ('two-steps')
            call examine_two_steps(work, error)
        case ('stars')
            call examine_stars(work, error, progress)
        end select
        statement = work%statement_t
    end subroutine examine_statement

    !> The rows of statements. For people it has the columns that some row fills; what a row has not stays empty.
    function statement_table(statements) result(table)
        type(statement_t), intent(in) :: statements(:)
        type(data_table_t) :: table

        type(statement_row_t), allocatable :: rows(:)
        integer :: i, k

        allocate (rows(0))
        do i = 1, size(statements)
            rows = [rows, statements(i)%rows]
        end do
        call table%column('statement')
        call table%column('case', 'a', 'case')
        call table%column('setting', 'a', 'setting')
        call table%column('runs')
        call add_columns([character(32) :: 'rms_x_mm', 'rms_y_mm', 'rms_z_mm'], 'RMS of the runs, mm|x', 'f10.4', &
                         any(rows%runs > 0))
        call add_columns([character(32) :: 'predicted_x_mm', 'predicted_y_mm', 'predicted_z_mm'], 'theory, mm|x', 'f10.4', &
                         any([(any(rows(k)%predicted > 0), k=1, size(rows))]))
        call add_columns([character(32) :: 'condition'], '|condition', 'es10.2', any(rows%condition > 0))
        call add_columns([character(32) :: 'torque_ratio'], '|torque ratio', 'f8.1', any(rows%torque_ratio > 0))
        call add_columns([character(32) :: 'stars'], '|stars', 'f8.1', any(rows%stars > 0))
        call add_columns([character(32) :: 'sigma_x_arcsec', 'sigma_y_arcsec', 'sigma_boresight_arcsec'], &
                         'sigma, arcsec|x', 'f8.3', any([(any(rows(k)%camera_sigma > 0), k=1, size(rows))]))
        do i = 1, size(statements)
            do k = 1, size(statements(i)%rows)
                associate (row => statements(i)%rows(k))
                    call table%add(statements(i)%name, row%case_name, row%setting)
                    call table%add(row%runs)
                    call table%add(row%rms/MILLIMETRE, row%runs > 0)
                    call table%add(row%predicted/MILLIMETRE, any(row%predicted > 0))
                    call table%add(row%condition, row%condition > 0)
                    call table%add(row%torque_ratio, row%torque_ratio > 0)
                    call table%add(row%stars, row%stars > 0)
                    call table%add(row%camera_sigma/ARCSECOND, any(row%camera_sigma > 0))
                end associate
            end do
        end do

    contains

        !> Columns of one kind; not for people where no row has them.
        subroutine add_columns(names, heading, layout, shown)
            character(*), intent(in) :: names(:), heading, layout
            logical, intent(in) :: shown

            character(9), parameter :: MORE(3) = [character(9) :: '', '|y', '|z']
            integer :: j

            do j = 1, size(names)
                call table%column(trim(names(j)), pick_text(shown, layout, ''), pick_text(j == 1, heading, pick_text( &
                    index(names(j), 'boresight') > 0, '|boresight', trim(MORE(j)))))
            end do
        end subroutine add_columns
    end function statement_table
end module gracecg_studies_statements
