!> Merging the shards of a campaign.
module gracecg_studies_campaign_merge
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text
    use gracecg_studies_campaign, only: campaign_t, campaign_entry_t, new_campaign, summarise
    implicit none
    private
    public :: merge_campaigns, check_settings

    real(dp), parameter :: AGREEMENT = 1e-6_dp
    !! Relative difference up to which two results of one run agree. On one machine they are equal;
    !! another processor may round otherwise

contains

    !> The union of the runs, in their order, with its statistics. A run that several parts have is
    !> taken from the first of them.
    !>
    !> Fails when seed, number of runs, cases or algorithms of the parts differ, when two parts
    !> contradict each other, or when some entry is left without any run.
    subroutine merge_campaigns(parts, names, whole, missing, error)
        type(campaign_t), intent(in) :: parts(:)    !! At least one
        character(*), intent(in) :: names(:)        !! Of their files, for messages
        type(campaign_t), intent(out) :: whole
        integer, intent(out) :: missing             !! Runs that no part has, over all entries
        type(error_t), allocatable, intent(out) :: error

        integer :: p, a, i

        missing = 0
        associate (first => parts(1))
            do p = 2, size(parts)
                call check_settings(first, parts(p), trim(names(1))//' and '//trim(names(p)), error)
                if (allocated(error)) return
            end do
            whole = new_campaign(first%algorithms, size(first%cases), first%seed, first%runs, 1, 1)
            whole%cases = first%cases
        end associate
        do i = 1, size(whole%cases)
            do a = 1, size(whole%algorithms)
                call merge_entry(parts, names, a, i, whole, error)
                if (allocated(error)) return
                missing = missing + whole%runs - size(whole%entries(a, i)%run)
                call summarise(whole, a, i)
            end do
        end do
    end subroutine merge_campaigns

    !> Fails unless two campaigns have the same seed, runs, cases, settings and algorithms.
    subroutine check_settings(first, other, files, error)
        type(campaign_t), intent(in) :: first, other
        character(*), intent(in) :: files           !! What they are, for messages: 'a.csv and b.csv'
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (first%seed /= other%seed) then
            call fail(error, files//' have different seeds: '//integer_text(first%seed)//' and '// &
                      integer_text(other%seed))
        else if (first%runs /= other%runs) then
            call fail(error, files//' are of campaigns of '//integer_text(first%runs)//' and '// &
                      integer_text(other%runs)//' runs')
        else if (size(first%cases) /= size(other%cases) .or. &
                 size(first%algorithms) /= size(other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        else if (any(first%cases%name /= other%cases%name) .or. &
                 any(first%algorithms /= other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        end if
        if (allocated(error)) return
        do i = 1, size(first%cases)
            if (first%cases(i)%checksum == other%cases(i)%checksum) cycle
            call fail(error, files//' have different settings of the case '//trim(first%cases(i)%name))
            return
        end do
    end subroutine check_settings

    elemental logical function agree(x, y)
        real(dp), intent(in) :: x, y

        agree = abs(x - y) <= AGREEMENT*max(abs(x), abs(y))
    end function agree

    !> The runs of case i with algorithm a, from all parts.
    subroutine merge_entry(parts, names, a, i, whole, error)
        type(campaign_t), intent(in) :: parts(:)
        character(*), intent(in) :: names(:)
        integer, intent(in) :: a, i
        type(campaign_t), intent(inout) :: whole
        type(error_t), allocatable, intent(out) :: error

        type(campaign_entry_t) :: new
        integer, dimension(whole%runs) :: source, place     ! the part that has a run, and where it stands in it; 0: none
        integer :: p, k

        source = 0
        do p = 1, size(parts)
            new = parts(p)%entries(a, i)
            do k = 1, size(new%run)
                associate (run => new%run(k))
                    if (source(run) == 0) then
                        source(run) = p
                        place(run) = k
                    else if (.not. same_estimate(parts(source(run))%entries(a, i), place(run), new, k)) then
                        call fail(error, trim(names(source(run)))//' and '//trim(names(p))// &
                                  ' contradict each other: '//trim(whole%cases(i)%name)//', '// &
                                  trim(whole%algorithms(a))//', run '//integer_text(run))
                        return
                    end if
                end associate
            end do
            call new%keep(pack([(k, k=1, size(new%run))], source(new%run) == p))
            call whole%entries(a, i)%add(new)
        end do
        if (all(source == 0)) &
            call fail(error, 'no file has a run of '//trim(whole%cases(i)%name)//', '//trim(whole%algorithms(a)))
        whole%entries(a, i)%predicted = parts(1)%entries(a, i)%predicted
    end subroutine merge_entry

    pure logical function same_estimate(first, i, other, k) result(same)
        type(campaign_entry_t), intent(in) :: first, other
        integer, intent(in) :: i, k         !! Places of the run in them

        same = all(agree(first%offset(:, i), other%offset(:, k))) .and. (first%converged(i) .eqv. other%converged(k))
    end function same_estimate
end module gracecg_studies_campaign_merge
